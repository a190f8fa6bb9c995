"""The certificate of a session, for a page and for paper.

content    what it says, in order, in the reader's language and units
facts      machine, instruments, conventions
results    verdict, before and after, balance quality, masses, runs, coefficients, findings
sheet      headings, facts, tables, pictures: what a certificate is put together from
pdf        a sheet as PDF, the same bytes every time
ink        a picture drawn into a PDF
paint      what the classes of a picture look like, read from the pages' style sheet
"""
