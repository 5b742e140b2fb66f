"""Any result -> table, JSON, figures."""

SECTIONS = ("friction", "diagnosis", "compensator", "recording")  # sections of a report that can be left out
ENDINGS = {"html": ".html", "pdf": ".pdf", "markdown": ".md", "json": ".json"}  # of the formats of a report
