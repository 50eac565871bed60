"""What acts from outside: a class an agent, for the simulator and for the fit."""
