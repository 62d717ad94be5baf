"""Li et al. 2020 and 2021: friction dynamics of one and two stages."""
