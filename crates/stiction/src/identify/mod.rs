//! Models identified from recorded loops: linear ones of the process, and of the valve before it.
