"""Scopes that each operation needs.

An operation is a route's name. A route that is not named here is refused, whoever asks; a test sees that all are.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from service.model.access import Scope

LOOKERS: frozenset[Scope] = frozenset({"read", "technician", "admin"})
DOERS: frozenset[Scope] = frozenset({"technician", "admin"})
SENDERS: frozenset[Scope] = frozenset({"bridge", "technician", "admin"})
KEEPERS: frozenset[Scope] = frozenset({"admin"})
EVERYONE: frozenset[Scope] | None = None
"""No token is needed: what the operation tells or does is no secret."""

_OPERATIONS: tuple[tuple[frozenset[Scope] | None, tuple[str, ...]], ...] = (
    (EVERYONE, ("get_health", "get_liveness", "get_readiness", "openapi", "show_api_document")),
    # A bridge sends what a balancer measured and can do nothing else: not even bind its source, or read.
    (SENDERS, ("add_readings", "add_answer", "add_block")),
    (
        LOOKERS,
        (
            "get_metrics",
            "list_machines",
            "get_machine",
            "list_influence",
            "get_typical_influence",
            "list_catalogues",
            "get_catalogue",
            "get_stock",
            "list_history",
            "get_session_history",
            "list_sources",
            "list_readings",
            "list_sessions",
            "get_session",
            "get_log",
            "get_report",
            "get_now",
            "list_answers",
            "follow",
            "suggest_trial_masses",
            "get_plan",
            "get_front",
            "ask_what_if",
            "list_arrangements",
            "get_arrangement",
            "get_arrangement_front",
            "ask_arrangement_what_if",
            "list_place_sets",
            "list_parts",
            "list_part_history",
            "list_designs",
            "get_design",
            "get_design_verdict",
            "check_design",
            "evaluate_design",
            "list_design_studies",
            "get_design_study",
            "list_design_study_versions",
            "get_design_study_version",
            "list_design_runs",
            "get_design_run",
            "get_design_run_now",
            "follow_design_run",
        ),
    ),
    (
        DOERS,
        (
            "create_machine",
            "change_machine",
            "learn_influence",
            "create_catalogue",
            "change_catalogue",
            "book_stock",
            "bind_source",
            "open_session",
            "change_session",
            "add_run",
            "change_run",
            "withdraw_readings",
            "add_correction",
            "add_plan",
            "reserve_plan",
            "release_plan",
            "fit_plan",
            "unfit_plan",
            "add_arrangement",
            "mount_arrangement",
            "put_place_set",
            "weigh_parts",
            "optimise_design",
            "trade_design_off",
            "create_design_study",
            "change_design_study",
            "start_design_run",
            "stop_design_run",
        ),
    ),
    (KEEPERS, ("import_session",)),
    # Pages
    (
        EVERYONE,
        (
            *("get_static", "get_icon", "get_worker", "get_manifest", "show_offline"),
            *("show_login", "log_in", "log_out", "show_preferences", "change_preferences"),
        ),
    ),
    (
        LOOKERS,
        (
            "home",
            "show_report",
            "show_report_json",
            "get_report_pdf",
            "get_report_csv",
            "sessions_page",
            "runs_page",
            "show_session",
            "show_step",
            "show_front",
            "follow_page",
            "machines_page",
            "machine_page",
            "boxes_page",
            "box_page",
            "sources_page",
        ),
    ),
    (
        DOERS,
        (
            "new_session",
            "begin_session",
            "choose_box",
            "close_session",
            "type_run",
            "take_run",
            "exclude_run",
            "repeat_trial",
            "begin_stop",
            "lock_machine",
            "trial_mass_on",
            "plan_on",
            "release_machine",
            "cancel_stop",
            "correct_stop",
            "make_correction",
            "teach_machine",
            "make_plan",
            "make_plan_again",
            "masses_off",
            "new_machine",
            "store_machine",
            "edit_machine",
            "save_machine",
            "new_box",
            "store_box",
            "book_box",
            "mount_source",
        ),
    ),
)

OPERATIONS: Mapping[str, frozenset[Scope] | None] = MappingProxyType(
    {name: scopes for scopes, names in _OPERATIONS for name in names}
)
