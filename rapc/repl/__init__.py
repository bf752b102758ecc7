"""The interactive debugger's place in the house; nothing lives here yet."""
