"""`drumtrue chaos`: faults done to a running service under load, and what is stored counted afterwards.

instances: the service as processes that can be killed, starved of disk, or given another clock. server: a PostgreSQL of
the campaign's own. load: bridges and technicians who write down what was acknowledged. judging: what is stored against
that. campaign: the faults, one after the other.
"""
