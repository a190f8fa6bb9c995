"""From raw waveforms and key-phasor edges to 1x vectors: pure functions on arrays.

| module | does |
|---|---|
| `block` | a block of samples, its channels and its key-phasor edges |
| `edges` | edges in a sampled tachometer signal, between the samples |
| `revolutions` | missed and extra edges repaired or refused; rotor angle and speed at any time |
| `steadying` | edges put on the smooth course that they follow, and how far it may be off |
| `windows` | tapers over the turns of a block |
| `orders` | 1x and harmonics by weighted least squares in the angle domain |
| `scatter` | standard deviation of the 1x vector, from what is left around it |
| `wander` | what the 1x vector does with the speed, and a drift that nothing explains |
| `neighbours` | a tone of another machine beside the 1x component |
| `close_tones` | a tone too near 1x for the taper, fitted jointly and taken out |
| `pulses` | several marks a turn, told from the vibration |
| `integrity` | clipping and dropouts |
| `broadband` | overall rms in a band |
| `chain` | all of it: `measure(block, settings)` |
| `directions` | horizontal, vertical and axial side by side: is it unbalance? |

Conventions: the rotor angle is 0 when the mark passes the pick-up and grows as the rotor turns, rad; a signal is
Re(c exp(j angle)), so its lag (degrees turned from the mark to the next positive peak) is -arg c. Inside, SI and peak
values; the unit, detection and phase sense of a reading are put on at the end of `chain`.
"""
