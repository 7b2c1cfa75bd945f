"""The exercises of the course in ``course/``: what is right, computed from the definitions, and what is often answered instead."""
