//! The messages, held to bytes that were written by hand, and to whatever a network may bring.
