"""Many runs: batches of machines in vector lanes, Monte Carlo, grids, and maps made of them."""
