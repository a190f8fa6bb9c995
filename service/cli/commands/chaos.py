"""`drumtrue chaos`: a campaign of faults, and what is left of what was acknowledged."""

from __future__ import annotations

from typing import Annotated

import typer


def chaos(
    kills: Annotated[int, typer.Option(min=0, help="How often a service is killed (kill -9).")] = 200,
    others: Annotated[int, typer.Option(min=0, help="How often each other fault is done.")] = 5,
    engine: Annotated[str, typer.Option(help="Storage: sqlite, or a postgresql of its own.")] = "sqlite",
    replicas: Annotated[int, typer.Option(min=1, max=8, help="Services over the one database (postgresql).")] = 1,
    seed: Annotated[int, typer.Option(min=0, max=2**31, help="Which moments.")] = 1,
    within: Annotated[float, typer.Option(min=0.0, max=60.0, help="Longest pause before a fault, s.")] = 1.0,
    slack: Annotated[float, typer.Option(min=0.0, max=600.0, help="For a machine with other load, s.")] = 0.0,
    only: Annotated[
        list[str] | None, typer.Option(help="No other faults than this, besides kills; repeatable.")
    ] = None,
) -> None:
    """Break a service under load again and again: nothing acknowledged may be lost or doubled.

    Works in a folder and a database of its own. Ends with status 1 where something was not as it was promised.
    """
    from service.chaos.campaign import FAULTS, CampaignOptions, run

    if engine not in ("sqlite", "postgresql"):
        raise typer.BadParameter(f"{engine!r} is no engine; use sqlite or postgresql", param_hint="--engine")
    if unknown := set(only or ()) - set(FAULTS):
        raise typer.BadParameter(f"{min(unknown)!r} is no fault; use one of {', '.join(FAULTS)}", param_hint="--only")
    wishes = CampaignOptions(
        kills=kills,
        others=others,
        engine=engine,
        replicas=replicas,
        seed=seed,
        within_s=within,
        only=tuple(only or ()),
        slack_s=slack,
    )
    outcome = run(wishes, lambda line: print(line, flush=True))
    found = outcome.judgement
    print("done: " + ", ".join(f"{name} {count}" for name, count in sorted(outcome.done.items())))
    for name, why in sorted(outcome.not_done.items()):
        print(f"not done: {name}, {why}")
    print(
        f"acknowledged: {found.readings} readings, {found.sessions} sessions, {found.closed} of them closed, "
        f"{found.fitted} with a fitted plan, {found.pieces} pieces out of the box; "
        f"{outcome.interrupted} requests had no answer and were sent again"
    )
    print(f"chain of the history: {found.entries} entries")
    for line in found.wrong:
        print(f"WRONG: {line}")
    print("nothing lost, nothing doubled" if not found.wrong else f"{len(found.wrong)} things are wrong")
    raise SystemExit(bool(found.wrong))


def histories(
    requests: Annotated[int, typer.Option(min=1, help="How many requests in all.")] = 100_000,
    engine: Annotated[str, typer.Option(help="Storage: sqlite, or a postgresql of its own.")] = "sqlite",
    replicas: Annotated[int, typer.Option(min=1, max=8, help="Services over the one database.")] = 1,
    kills: Annotated[bool, typer.Option(help="Kill services meanwhile.")] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**31, help="Which requests.")] = 1,
) -> None:
    """Write down what 8 clients ask at once and are answered, and check it.

    Looks for torn reads, lost updates, doubled effects, skipped versions and 5xx; ends with status 1 where it finds
    some. Works in a folder and a database of its own.
    """
    from service.chaos.histories import HistoryOptions, run

    if engine not in ("sqlite", "postgresql"):
        raise typer.BadParameter(f"{engine!r} is no engine; use sqlite or postgresql", param_hint="--engine")
    found = run(HistoryOptions(requests, engine, replicas, kills, seed), lambda line: print(line, flush=True))
    told = ", ".join(f"{status or 'no answer'}: {count}" for status, count in sorted(found.statuses.items()))
    print(f"{found.requests} requests, {found.kills} kills; {told}")
    for line in found.wrong:
        print(f"WRONG: {line}")
    print("every answer fits one order of the requests" if not found.wrong else f"{len(found.wrong)} things are wrong")
    raise SystemExit(bool(found.wrong))
