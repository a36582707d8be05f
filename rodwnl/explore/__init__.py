"""A page on this machine, in which a rod is changed with sliders and everything known about it follows."""
