"""Pages of parts: what is weighed, which part goes where, what was mounted.

set_form     the form of a set of places: rings round the drum, along the shaft
scale        what was typed on the weighing page
asked        the form that asks for an arrangement, and what it asks
views        pictures and figures of an arrangement
mounting     the moves one after the other, with one part lying aside at most
paper        the certificate of an arrangement
"""
