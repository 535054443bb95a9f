"""Contact laws, contact points and start states: what happens at one contact, and the compiled kernels for a period of it.

A law is a frozen dataclass in a file of its own that becomes rows of a contact table; nothing here knows structures or
frequencies. Imports only `support`. Begin with `law.py` (what a law is), then `macroslip.py` (the
simplest law) and `protocol.py` (the kernels).
"""
