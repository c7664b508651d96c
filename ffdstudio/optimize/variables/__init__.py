"""Design variables: what may move, in which directions, whitened by a metric."""
