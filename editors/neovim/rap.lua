-- RAP in Neovim 0.7 or later. Copy this file to ~/.config/nvim/plugin/rap.lua.
vim.api.nvim_create_autocmd({ "BufRead", "BufNewFile" }, {
  pattern = "*.rap",
  command = "setfiletype rap",
})

-- The keys of Neovim 0.11, for older versions.
local keys = {
  K = function() vim.lsp.buf.hover() end,
  gra = function() vim.lsp.buf.code_action() end,
  grn = function() vim.lsp.buf.rename() end,
  grr = function() vim.lsp.buf.references() end,
  gO = function() vim.lsp.buf.document_symbol() end,
}

local function attached(client, buffer)
  vim.bo[buffer].omnifunc = "v:lua.vim.lsp.omnifunc"
  vim.bo[buffer].tagfunc = "v:lua.vim.lsp.tagfunc"
  vim.bo[buffer].formatexpr = "v:lua.vim.lsp.formatexpr()"
  if vim.fn.has("nvim-0.11") == 0 then
    for key, run in pairs(keys) do
      vim.keymap.set("n", key, run, { buffer = buffer })
    end
  else
    vim.lsp.completion.enable(true, client.id, buffer, { autotrigger = true })
  end
  if vim.lsp.inlay_hint then
    pcall(vim.lsp.inlay_hint.enable, true, { bufnr = buffer })
  end
  if vim.lsp.on_type_formatting then
    vim.lsp.on_type_formatting.enable(true, { client_id = client.id })
  end
  vim.keymap.set("n", "grx", vim.lsp.codelens.run, { buffer = buffer })
  vim.api.nvim_create_autocmd({ "BufEnter", "CursorHold", "InsertLeave" }, {
    buffer = buffer,
    callback = function() vim.lsp.codelens.refresh() end,
  })
end

-- The server ends with 2 if it cannot start, for example without its packages.
local function ended(status)
  if status == 2 then
    vim.notify("rapc lsp cannot start: pip install 'rapc[lsp]'", vim.log.levels.ERROR)
  end
end

local clients = {}
vim.api.nvim_create_autocmd("FileType", {
  pattern = "rap",
  callback = function(event)
    vim.bo.commentstring = "; %s"
    vim.bo.lisp = true
    vim.bo.syntax = "lisp"
    local folder = vim.fn.expand("<afile>:p:h")
    local mark = vim.fn.findfile("rapc.toml", folder .. ";")
    local root = mark == "" and folder or vim.fn.fnamemodify(mark, ":p:h")
    local own = root .. "/.venv/bin/rapc"
    local command = vim.fn.executable(own) == 1 and own or "rapc"
    if vim.fn.executable(command) == 0 then
      vim.notify("rapc was not found: pip install 'rapc[lsp]'", vim.log.levels.ERROR)
      return
    end
    local config = {
      name = "rapc",
      cmd = { command, "lsp" },
      root_dir = root,
      on_attach = attached,
      on_exit = vim.schedule_wrap(ended),
    }
    if vim.lsp.start then
      clients[root] = vim.lsp.start(config)
    else
      clients[root] = clients[root] or vim.lsp.start_client(config)
      vim.lsp.buf_attach_client(event.buf, clients[root])
    end
  end,
})

-- Go from a handler or a string in Python to the declaration of its primitive or datum.
vim.api.nvim_create_user_command("RapDeclaration", function()
  local file = vim.api.nvim_buf_get_name(0)
  for root, id in pairs(clients) do
    local client = vim.lsp.get_client_by_id(id)
    if client and vim.startswith(file, root .. "/") then
      local unit = client.offset_encoding
      local show = vim.lsp.util.show_document or vim.lsp.util.jump_to_location
      local params = vim.lsp.util.make_position_params(0, unit)
      local function answered(_, places)
        if places and places[1] then
          show(places[1], unit, { focus = true })
        else
          vim.notify("no declaration found")
        end
      end
      local request = { "textDocument/definition", params, answered }
      if vim.fn.has("nvim-0.11") == 1 then table.insert(request, 1, client) end
      client.request(unpack(request))
      return
    end
  end
  vim.notify("no server: open a RAP file of the project first")
end, {})
