"""The programs behind `make verify`, which run for an hour, can at least be begun."""

import importlib

from each import each

from verify.__main__ import TOPICS


@each("topic", TOPICS)
def test_every_topic_of_the_verification_finds_what_it_imports(topic):
    module = importlib.import_module(f"verify.{topic}")
    assert module.TITLE
    assert module.ABOUT
    assert callable(module.rows)
