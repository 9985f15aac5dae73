"""The seeders that `seeding.method` may name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.elastic_bands.relaxation_seeder import Relaxation
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.schedule import Search
from stplan.seeding.search.sequential_dijkstra import SequentialDijkstra
from stplan.seeding.seeder import Seeder

# A seeder of a problem, by the name of its method.
SEEDERS: Mapping[str, Callable[[PlanningProblem], Seeder]] = MappingProxyType(
    {
        SequentialDijkstra.name: SequentialDijkstra,
        Search.name: lambda problem: Search(Levels(problem)),
        Relaxation.name: Relaxation,
    }
)
