# SPDX-License-Identifier: Apache-2.0
"""Counts of work (table 2), of the first edit of a session. They do not depend on the machine."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from irt_usd import interrupt
from irt_usd.bench.paper.scenes import PaperScene


@dataclass(frozen=True)
class Counts:
    """What an update, or a full trace, did; over all cells (DESIGN 7)."""

    new_rays: int
    nodes_traversed: int
    intersections: int
    shadings: int
    tested: int
    retraced: int
    changed: int
    uncovered: int
    """Rays whose visible object changed."""
    whole_scene: int
    """Of those: rays for which the whole scene was searched."""

    @classmethod
    def of(cls, update: Mapping[str, Any]) -> "Counts":
        """Those of an update's statistics."""
        return cls(
            update["new_rays"],
            update["nodes_traversed"],
            update["intersections"],
            update["shadings"],
            update["tested_rays"],
            update["retraced_rays"],
            update["changed_rays"],
            update["uncovered_rays"],
            update["whole_scene_rays"],
        )

    @property
    def waste(self) -> float:
        """Rays retraced over rays changed; 0 where none was retraced."""
        return self.retraced / self.changed if self.changed else float(self.retraced)

    @property
    def tested_over_changed(self) -> float | None:
        """None where no ray changed."""
        return self.tested / self.changed if self.changed else None

    @property
    def from_history(self) -> float | None:
        """Share of uncovered points answered without tracing the whole scene; None: no point."""
        return 1 - self.whole_scene / self.uncovered if self.uncovered else None


@dataclass(frozen=True)
class SceneWork:
    """`full` is the full trace without a history, but for its nodes: all there are.

    A node is one that sees something, as in the paper, whose full trace has fewer nodes than
    pixels: all shares are taken of those. (The paper's full trace likewise has no nodes traversed;
    it says in the text how many there are.)
    """

    full: Counts
    rays: Mapping[str, int]
    """Of the full trace: primary, reflected, refracted, shadow."""
    history: Mapping[str, Any]
    """After the initial step: Renderer.update's."""
    edits: Mapping[str, Counts]
    """Each the first of a session."""
    cell_rays: Mapping[str, list[int]]
    """Rays traced, by cell: of the initial step, "full", and of each edit."""

    @property
    def tree_rays(self) -> int:
        """Rays of the trees: those that ask for a nearest hit."""
        return self.rays["primary"] + self.rays["reflected"] + self.rays["refracted"]

    def share(self, edit: str, kind: str) -> float:
        """A count of an edit as a share of the full trace's."""
        return float(getattr(self.edits[edit], kind) / getattr(self.full, kind))

    def counts_json(self, edit: str) -> dict[str, Any]:
        """For `--json`."""
        counts = self.full if edit == "full" else self.edits[edit]
        return {
            **asdict(counts),
            "waste": counts.waste,
            "tested_over_changed": counts.tested_over_changed,
            "from_history": counts.from_history,
        }


def count_work(scene: PaperScene) -> SceneWork:
    """Runs every edit as the first of its own session."""
    traced = scene.renderer(history=False).update(scene.initial)
    edits, cell_rays, history = {}, {}, {}
    for name, edit in scene.edits.items():
        interrupt.check()
        renderer = scene.renderer()
        initial = renderer.update(scene.initial)
        history = initial["history"]
        cell_rays["full"] = initial["cells"]["rays"]
        update = renderer.update(edit.change)
        edits[name] = Counts.of(update)
        cell_rays[name] = update["cells"]["rays"]
    full = Counts.of({**traced, "nodes_traversed": history["points"]})
    return SceneWork(full, traced["rays"], history, edits, cell_rays)


def mean_level(scene: PaperScene, deepest: int = 8) -> float:
    """Mean level of the nodes of all trees, a primary ray's being 1: the paper's, as we read it.

    Told from what initial steps hold that stop at each depth up to `deepest`, the default depth of
    views; a deeper limit adds levels and changes none.
    """
    nodes = [
        scene.renderer(depth=depth).update(scene.initial)["history"]["points"]
        for depth in range(deepest + 1)
    ]
    added = (after - before for before, after in zip([0, *nodes], nodes, strict=False))
    return float(sum(level * count for level, count in enumerate(added, start=1)) / nodes[-1])
