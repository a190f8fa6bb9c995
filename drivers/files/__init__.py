"""Recorded waveforms in files, as sources of readings: CSV, WAV and universal files (UFF, data set 58).

`recording` is what every reader returns, `csv_file`, `wav_file` and `uff_file` read one format each, `driver` cuts a
recording into blocks and sends them through the signal chain.
"""
