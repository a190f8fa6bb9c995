"""Pictures of design studies: curves, hodograph, linkage, section of a disc, gear pair, bars, front.

They are drawn from answered evaluations; every text is handed in, in the reader's language.
"""
