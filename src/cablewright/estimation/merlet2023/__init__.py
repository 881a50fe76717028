"""The estimator of Merlet and Papegay 2023, section III."""
