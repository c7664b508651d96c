"""What is shown of bodies and sections, computed without any graphics."""
