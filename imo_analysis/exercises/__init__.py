"""The exercises of ``course/``: what is right, computed from the definitions, and what is often answered instead."""
