"""Pictures, certificate and pages as images for the documents: `python -m tests.web.pictures.screenshots FOLDER`.

Pictures and certificate show the published drum, balanced with the box of the tests; the same every time but for the
browser's letters. The pages, in FOLDER/pages, are of the simulated drum; with `--everything` FOLDER gets every page as
it is held upright and lying instead, to be looked at.
"""

from __future__ import annotations

import sys
import tempfile
from io import BytesIO
from pathlib import Path

import pypdfium2
from markupsafe import Markup
from PIL import Image

from service.model.session import Session
from service.usecases.plans import plans
from service.usecases.sessions import reports, sessions
from service.web.assets import files
from service.web.certificate.content import certificate
from service.web.certificate.pdf import to_pdf
from service.web.pictures import bars, end_view, front, polar
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from tests.support.http.workshop import DRUM, Workshop, mass, on_rotor, workshop
from tests.support.pages.browser import browsing
from tests.web.pictures.walk import walker

WIDTH = 1240


def balanced(shop: Workshop) -> str:
    """A session with a plan that adds, takes off and leaves pieces, fitted and checked."""
    found = [
        {"plane": "1", "position_deg": 220.0, "mass_g": 50.0, "may": "remove"},
        {"plane": "2", "position_deg": 40.0, "mass_g": 20.0, "may": "stay"},
    ]
    machine = shop.machine(seen_from="gear side", rotation="cw", balance_grade_mm_s=16.0, vibration_limit_mm_s=0.5)
    key = shop.session(machine, technician="A. N. Other", on_rotor=found)
    shop.learn(key)
    plan = shop.fit(shop.plan(key, shop.correct(key), max_masses_per_plane=2))
    masses = [
        *on_rotor(plan["fitted"]),
        *(mass(p["plane"], -p["mass_g"], p["position_deg"]) for p in plan["taken_off"]),
    ]
    readings = [{**reading, "amplitude": reading["amplitude"] + 0.05} for reading in DRUM.readings(masses)]
    shop.post(f"/sessions/{key}/runs", {"kind": "check", "readings": readings})
    return key


def drawn(shop: Workshop, session: Session) -> list[Markup]:
    """The pictures of the session, the end views of both planes first."""
    reader, machine, plan = Reader(), session.machine, session.plans[-1]
    pieces = end_view.pieces_of(plan.changes, session.on_rotor)
    views = [end_view.end_view(machine, plane.name, reader, pieces=pieces) for plane in machine.planes]
    plots = [
        polar.polar_plot(machine, v.sensor, session.runs, reader, predicted=v, close_up=close)
        for v, close in ((plan.predicted[0], False), (plan.predicted[0], True))
    ]
    report = reports.report(shop.work, session.id)
    chosen = len(plan.placements)
    chart = front.front_chart(plans.front(shop.work, plan.id), "share of the limit", reader, chosen=chosen)
    return [to_svg(one) for one in (*views, *plots, bars.before_after(machine, report.before_after, reader), chart)]


def shrink(image: Image.Image, path: Path) -> None:
    """Store an image with as few colours as flat shapes need."""
    image.convert("RGB").quantize(128).save(path, optimize=True)


def pages(folder: Path) -> None:
    """Write the pages that the documents show."""
    with walker() as walk:
        walk.for_documents(folder, lambda path, png: shrink(Image.open(BytesIO(png)), path))


def everything(folder: Path) -> None:
    """Write every page, upright and lying."""
    with walker() as walk:
        walk.everything(folder)


def pictures(folder: Path) -> None:
    """Write pictures-light.png, pictures-dark.png and certificate.png."""
    style = files()["pictures.css"].decode()
    with (
        tempfile.TemporaryDirectory() as place,
        workshop(f"sqlite:///{place}/drumtrue.db") as shop,
        browsing() as browser,
    ):
        session = sessions.get(shop.work, balanced(shop))
        shown = "".join(f"<div>{picture}</div>" for picture in drawn(shop, session))
        for theme, ground in (("light", "#ffffff"), ("dark", "#12171c")):
            page = browser.new_page(viewport={"width": WIDTH, "height": 600})
            grid = f"body{{margin:16px;background:{ground};display:grid;grid-template-columns:1fr 1fr;gap:24px}}"
            page.set_content(f"<html data-theme={theme}><style>{style}{grid}</style>{shown}")
            page.screenshot(path=folder / f"pictures-{theme}.png", full_page=True)
            page.close()
            shrink(Image.open(folder / f"pictures-{theme}.png"), folder / f"pictures-{theme}.png")
        sheet = certificate(session, reports.report(shop.work, session.id), Reader())
        document = pypdfium2.PdfDocument(to_pdf(sheet))
        shrink(document[0].render(scale=1.4).to_pil(), folder / "certificate.png")
        document.close()


def main(arguments: list[str]) -> None:
    """Draw what is asked for."""
    folder = Path(next(one for one in arguments if not one.startswith("-")))
    if "--everything" in arguments:
        folder.mkdir(parents=True, exist_ok=True)
        everything(folder)
    else:
        (folder / "pages").mkdir(parents=True, exist_ok=True)
        pictures(folder)
        pages(folder / "pages")


if __name__ == "__main__":
    main(sys.argv[1:])
