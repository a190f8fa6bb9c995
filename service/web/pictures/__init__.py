"""Pictures of a session, drawn from its documents: fast, small, the same on a page and in a PDF.

    drawing    lines, shapes and words in a picture; nothing here knows what they mean
    svg        a picture as SVG text, painted by classes (service/web/static/pictures.css)
    compass    where an angle of the machine's conventions lies on paper
    reader     the reader's language, numbers and units; all text of a picture goes through it
    scales     rings and ticks at round numbers, in the reader's units
    words      names and masses as text
    chart      axes of a chart
    paper      rings, spokes, key-phasor mark and senses of a polar plot
    polar      vibration of a sensor: runs, what each change of masses did, prediction, limit
    masses     correction of a plane with its region, and the pieces that make it up
    part_places a drum with its parts, from the end and unrolled
    ends       end view of the drum: which mass goes into which hole
    bars       before and after, with the limit
    front      what a further mass would bring
    trend      a machine over its sessions
    dials      amplitude, phase and steadiness of a live reading

Every picture has a title and a description for those who do not see it. On paper y counts downwards.
"""
