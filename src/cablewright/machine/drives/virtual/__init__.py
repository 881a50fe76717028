"""Virtual CANopen drives, with the simulated plant behind them: everything can be tried without hardware."""
