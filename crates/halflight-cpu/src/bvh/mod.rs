//! Triangle hierarchy and shadow-ray packets.
