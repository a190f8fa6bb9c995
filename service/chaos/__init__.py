"""`drumtrue chaos`: faults done to a running service under load, and what is stored counted afterwards.

instances: the service as processes that can be killed, starved of disk, or given another clock. server: a PostgreSQL of
the campaign's own, which can be cut off, ended or made to hang. gate: what stands between clients and a service, such
as a sign-in page. network: faults of what is around a service. old_database: migrations that are killed. load: bridges
and technicians who write down what was acknowledged. field_bridge: the product's own bridge, whose clock may be wrong.
crew: all of them at work. judging: what is stored against what was acknowledged. campaign: the faults, one after the
other.

`drumtrue histories`: histories, made of rounds (history_round), and what is wrong with them (history_checks).
"""
