//! Fixtures shared by tests and benches.
