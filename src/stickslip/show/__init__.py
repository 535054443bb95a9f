"""What a person sees: figures (`plots`), the page of a result (`report`) and the explorer in the browser (`explorer`).

Imports `study` and below; results find their figures and sentences through `support/renderers.py`.
"""
