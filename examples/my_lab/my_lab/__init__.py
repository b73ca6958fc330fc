"""A lab's own effect, task and questionnaire."""
