-- Read by `nvim --headless -S`: waits for results of the language server.
function settle(ready)
  assert(vim.wait(20000, ready, 20), "no answer")
end

function ask(method, params)
  local found = vim.lsp.buf_request_sync(0, method, params, 20000)
  for _, one in pairs(found or {}) do
    if one.error then error(vim.inspect(one.error)) end
    return one.result
  end
end

function at(text)
  assert(vim.fn.search(text, "cw") > 0, text)
  return vim.lsp.util.make_position_params()
end

function codes()
  return vim.tbl_map(function(one) return one.code end, vim.diagnostic.get(0))
end

function answer(file, value)
  vim.fn.writefile({ vim.json.encode(value) }, file)
end
