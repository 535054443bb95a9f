"""Non-unique responses: samples, histories and bounds over start states, and the freedom of friction forces."""
