"""Single faults put into the core, one at a time: which of them do the tests see?"""
