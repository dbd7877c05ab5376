//! the FFT-based kernelized correlation filter.
