-- RAP in Neovim 0.7 or later. Copy this file to ~/.config/nvim/plugin/rap.lua.
vim.api.nvim_create_autocmd({ "BufRead", "BufNewFile" }, {
  pattern = "*.rap",
  command = "setfiletype rap",
})

local clients = {}
vim.api.nvim_create_autocmd("FileType", {
  pattern = "rap",
  callback = function(event)
    vim.bo.commentstring = "; %s"
    vim.bo.lisp = true
    local folder = vim.fn.expand("<afile>:p:h")
    local mark = vim.fn.findfile("rapc.toml", folder .. ";")
    local root = mark == "" and folder or vim.fn.fnamemodify(mark, ":p:h")
    local own = root .. "/.venv/bin/rapc"
    clients[root] = clients[root] or vim.lsp.start_client({
      name = "rapc",
      cmd = { vim.fn.executable(own) == 1 and own or "rapc", "lsp" },
      root_dir = root,
    })
    vim.lsp.buf_attach_client(event.buf, clients[root])
  end,
})
