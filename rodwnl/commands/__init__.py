"""One module a command; `rodwnl.cli` says what such a module holds."""
