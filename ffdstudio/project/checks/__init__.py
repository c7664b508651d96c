"""What is checked while shapes change: cells, folds, limits of drags, frozen layers."""
