"""CAN logs as frames.

`can_log` tells the kind of a log and reads it by `asc`, `candump`, `trc`, `table`, `busmaster` (text, line by line) or
`binary`; `frame` is what all of them give and turns their times into times of day, `dates` reads dates, `lines` gives
the lines of a text.
"""
