"""The language server: `rapc lsp`."""
