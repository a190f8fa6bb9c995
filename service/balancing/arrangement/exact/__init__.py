"""Complete searches and bounds: what lets an answer be called proved.

=============== =================================================================
slots           the problem as a matching: spare slots, dummy parts
enumeration     every arrangement of a small problem
bounds          a lower bound from matchings
region          where every better residual must lie
near_pairs      pairs of rows of two tables whose sum lies in a box
halves          every better arrangement, by meeting in the middle
changes         cycles of parts through slots
few_moves       every better arrangement of up to four moves
=============== =================================================================
"""
