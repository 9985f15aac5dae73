"""Large-neighbourhood search on finished plans: other homotopy classes, tried until the budget is spent."""
