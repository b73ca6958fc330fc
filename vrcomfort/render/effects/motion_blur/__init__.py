"""Motion blur from a velocity buffer, per eye."""
