# SPDX-License-Identifier: Apache-2.0
"""Cases of a page, whole or in part, as files that `kalfem check` reads."""

import yaml


def value_at(node, keys):
    """The value of a key of a key ..., made where it is absent; lists count from 0."""
    for key in keys:
        if isinstance(node, yaml.SequenceNode):
            node = node.value[int(key)]
            continue
        found = next((value for name, value in node.value if name.value == key), None)
        if found is None:
            found = yaml.MappingNode("tag:yaml.org,2002:map", [])
            node.value.append((yaml.ScalarNode("tag:yaml.org,2002:str", key), found))
        node = found
    return node


def without(node, path):
    *parents, last = path.split(".")
    parent = value_at(node, parents)
    parent.value = [entry for entry in parent.value if entry[0].value != last]


def lay_over(base, part):
    """The part's values in the places of the base's, key by key."""
    for key, value in part.value:
        old = next((i for i, entry in enumerate(base.value) if entry[0].value == key.value), None)
        if old is None:
            base.value.append((key, value))
        elif isinstance(value, yaml.MappingNode) and isinstance(base.value[old][1], yaml.MappingNode):
            lay_over(base.value[old][1], value)
        else:
            base.value[old] = (key, value)


def completed(part, base, place="", left_out=""):
    """The text of the case `base` with `part` laid over its section `place`, without the keys `left_out`."""
    case, section = yaml.compose(base), yaml.compose(part)
    for path in filter(None, map(str.strip, left_out.split(","))):
        without(case, path)
    lay_over(value_at(case, place.split(".") if place else []), section)
    return yaml.serialize(case)


def is_whole(text):
    return any(line.startswith("kalfem:") for line in text.splitlines())
