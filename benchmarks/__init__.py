"""Speed and size, measured against named peers: ratios in one run. `make bench`, or `python -m benchmarks NAME…`."""
