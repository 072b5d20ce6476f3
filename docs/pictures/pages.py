# SPDX-License-Identifier: Apache-2.0
"""Screenshots of pages, and plots as the Python package draws them."""

from drawing import EXAMPLES, command, picture, results, run, scratch, screenshot


@picture
def chain_parameters():
    return run("chain/chain.yaml").plot("parameters")


@picture
def chain_displacement():
    return run("chain/chain.yaml").plot("states", points=["body.3"])


@picture
def damper_law():
    return run("start/component/case.yaml").plot("law")


@picture
def measured():
    return screenshot(results("start/measured/case.yaml") / "report.html", 1000)


@picture
def updating():
    return screenshot(results("start/plate/case.yaml") / "report.html", 1000)


@picture
def deck():
    page = scratch("check.html")
    command("check", EXAMPLES / "start/plate/plate.bdf", "--page", page)
    return screenshot(page, 900)
