"""Gains: chosen by rule and by search, judged on exact pencils and on simulations, for every observer by the same wish."""
