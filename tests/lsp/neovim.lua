-- Read by `nvim --headless`: uses every feature of the server, as a user does, and writes
-- what the editor shows to `result.json`. The session is a coroutine, so that the editor
-- handles keys and answers while the session waits.
--
-- A version of Neovim without a feature sends the request of the feature all the same.

local shown = {}
vim.g.loaded_python3_provider = 0 -- takes seconds to search
vim.notify = function(message) table.insert(shown, message) end
vim.lsp.handlers["window/showMessage"] = function(_, found) vim.notify(found.message) end
local begin = vim.lsp.start and "start" or "start_client"
local start = vim.lsp[begin]
vim.lsp[begin] = function(config, ...)
  config.init_options = { errorDelay = 0, delay = 0 }
  config.flags = { debounce_text_changes = 10 }
  return start(config, ...)
end

local wanted, offered
vim.ui.select = function(items, options, choose)
  offered = vim.tbl_map(options.format_item or tostring, items)
  for at, title in ipairs(offered) do
    if title:find(wanted, 1, true) then return choose(items[at], at) end
  end
  choose()
end

local session

local function go_on()
  local ok, problem = coroutine.resume(session)
  if not ok then
    local trace = debug.traceback(session, problem)
    vim.fn.writefile({ vim.fn.json_encode({ problem = trace }) }, "result.json")
  end
  if coroutine.status(session) == "dead" then vim.cmd("qa!") end
end

local function pause(milliseconds)
  vim.defer_fn(go_on, milliseconds)
  coroutine.yield()
end

-- Wait until a function returns a value, and return the value.
local function settle(ready)
  for _ = 1, 6000 do -- at least a minute
    local found = ready()
    if found then return found end
    pause(10)
  end
  error("no answer: " .. vim.inspect({ shown, offered, vim.api.nvim_buf_get_lines(0, 0, -1, true) }))
end

-- Send a request and return the answer.
local function ask(method, params)
  local answers
  vim.lsp.buf_request_all(0, method, params, function(found) answers = found end)
  for _, one in pairs(settle(function() return answers end)) do
    if one.error or one.err then error(vim.inspect(one)) end
    return one.result
  end
end

local function client()
  local _, found = next((vim.lsp.get_clients or vim.lsp.get_active_clients)())
  return found
end

local function here()
  return vim.lsp.util.make_position_params(0, client().offset_encoding)
end

local function document() return { textDocument = here().textDocument } end

-- Move the cursor to a text.
local function at(text)
  vim.fn.cursor(1, 1)
  assert(vim.fn.search("\\V" .. text, "cW") > 0, text)
end

local function text(file)
  local buffer = file and vim.fn.bufnr(file) or 0
  return table.concat(vim.api.nvim_buf_get_lines(buffer, 0, -1, true), "\n") .. "\n"
end

-- Replace a text in the buffer, once.
local function edit(old, new)
  local start, stop = text():find(old, 1, true)
  assert(start, old)
  local changed = text():sub(1, start - 1) .. new .. text():sub(stop + 1, -2)
  vim.api.nvim_buf_set_lines(0, 0, -1, true, vim.split(changed, "\n"))
end

local function codes()
  local found = vim.tbl_map(function(one) return one.code end, vim.diagnostic.get(0))
  table.sort(found)
  return found
end

-- Wait for a finding of a rule; without a rule, for the end of all findings.
local function finding(rule)
  settle(function()
    return rule and vim.tbl_contains(codes(), rule) or not rule and #codes() == 0
  end)
end

-- Wait for a change of the buffer by a function, return the text, and restore the text.
local function changed(run)
  local before = text()
  run()
  local after = settle(function() return text() ~= before and text() end)
  vim.api.nvim_buf_set_lines(0, 0, -1, true, vim.split(before:sub(1, -2), "\n"))
  return after
end

-- Read the buffer again, without changes, and wait for the check. The server offers to
-- extract the steps of `tour` only after the check of the present text.
local function reset()
  vim.cmd("edit!")
  finding()
  if vim.fn.expand("%:t") ~= "raps.rap" then return end
  local params = vim.lsp.util.make_given_range_params({ 12, 6 }, { 13, 17 })
  params.context = { diagnostics = {} }
  settle(function()
    for _, one in ipairs(ask("textDocument/codeAction", params) or {}) do
      if one.title:find("Extract") then return true end
    end
  end)
end

-- Wait for a floating window, return its text, and close it.
local function popup(run)
  run()
  return settle(function()
    for _, window in ipairs(vim.api.nvim_list_wins()) do
      if vim.api.nvim_win_get_config(window).relative ~= "" then
        local buffer = vim.api.nvim_win_get_buf(window)
        local lines = vim.api.nvim_buf_get_lines(buffer, 0, -1, true)
        vim.api.nvim_win_close(window, true)
        return table.concat(lines, "\n")
      end
    end
  end)
end

-- Wait for a list of places, and return its entries: the file, the row and the text.
local function places(run)
  local function entries()
    for _, found in ipairs({ vim.fn.getqflist(), vim.fn.getloclist(0) }) do
      if #found > 0 then return found end
    end
  end
  vim.fn.setqflist({})
  vim.fn.setloclist(0, {})
  local window = vim.fn.win_getid()
  run()
  local found = settle(entries)
  vim.fn.win_gotoid(window)
  vim.cmd("silent only")
  return vim.tbl_map(function(one)
    local file = vim.fn.fnamemodify(vim.fn.bufname(one.bufnr), ":t")
    return { file, one.lnum, one.text }
  end, found)
end

-- Wait for the cursor in another place; return its file and row, and go back.
local function jumped(run)
  local file, row = vim.fn.bufname(), vim.fn.line(".")
  run()
  local found = settle(function()
    if vim.fn.bufname() ~= file or vim.fn.line(".") ~= row then
      return { vim.fn.expand("%:t"), vim.fn.line(".") }
    end
  end)
  vim.cmd("buffer " .. file)
  return found
end

-- Apply an action at the cursor or in a range, and return the text. Asks again until the
-- server has checked the text and offers the action.
local function action(title, options)
  local before = text()
  options = options or {}
  wanted = title
  return settle(function()
    if vim.fn.has("nvim-0.8") == 1 then
      vim.lsp.buf.code_action(options)
    else
      local diagnostics = vim.lsp.diagnostic.get_line_diagnostics()
      local context = vim.tbl_extend("keep", options.context or {}, { diagnostics = diagnostics })
      if options.range then
        vim.lsp.buf.range_code_action(context, options.range.start, options.range["end"])
      else
        vim.lsp.buf.code_action(context)
      end
    end
    pause(100)
    return text() ~= before and text()
  end)
end

-- Wait until the server has read a RAP.
local function known(name)
  settle(function()
    for _, one in ipairs(ask("workspace/symbol", { query = name }) or {}) do
      if one.name == name then return true end
    end
  end)
end

local function keys(typed)
  local coded = vim.api.nvim_replace_termcodes(typed, true, true, true)
  vim.api.nvim_input(coded)
end

local features = {}

function features.findings()
  edit("(t1 (go kitchen))", "(t1 (goo kitchen))\n      (t1 (go hall))")
  finding("unknown-rap")
  finding("duplicate-tag")
  local found = vim.tbl_map(function(one)
    local more = one.user_data.lsp
    return {
      one.lnum + 1,
      one.message,
      more.codeDescription.href,
      #(more.relatedInformation or {}),
    }
  end, vim.diagnostic.get(0))
  table.sort(found, function(one, other) return one[1] < other[1] end)
  reset()
  return found
end

function features.quick_fix()
  edit("go kitchen", "goo kitchen")
  finding("unknown-rap")
  at("goo")
  local found = action("Write `go`")
  reset()
  return found
end

function features.fix_all()
  edit("; Go to", "; rapc: ignore[unbound-variable]\n; Go to")
  finding("unused-suppression")
  local found = action("Apply all safe fixes", { context = { only = { "source.fixAll" } } })
  reset()
  return found
end

function features.suppress()
  edit("go hall", "go kitchen")
  finding("copied-step")
  at("(go kitchen)))))")
  local found = action("Ignore copied-step here")
  reset()
  return found
end

function features.declare()
  edit("(succeed (at robot ?place))", "(succeed (seen ?place north))")
  finding("undeclared-predicate")
  at("seen")
  local found = action("Declare the proposition `seen`")
  reset()
  return found
end

function features.define()
  edit("(go hall)", "(inspect hall => ?seen)")
  finding("unknown-rap")
  at("inspect")
  local found = action("Define the RAP `inspect`")
  reset()
  return found
end

function features.extract_and_inline()
  at("(t1")
  local row = vim.fn.line(".")
  local steps = { start = { row, 6 }, ["end"] = { row + 1, 17 } }
  local found = { extracted = action("Extract the steps into a RAP", { range = steps }) }
  at("(t1 (tour")
  found.inlined = action("Inline `tour-t1`")
  reset()
  return found
end

function features.hover()
  at("drive")
  return popup(vim.lsp.buf.hover)
end

function features.definition()
  at("drive")
  return jumped(vim.lsp.buf.definition)
end

function features.references()
  at("go kitchen")
  return vim.tbl_map(function(one)
    return { one[1], one[2] }
  end, places(vim.lsp.buf.references))
end

function features.highlight()
  at("?place")
  vim.lsp.buf.document_highlight()
  local count = settle(function()
    for name, number in pairs(vim.api.nvim_get_namespaces()) do
      if name:find("lsp") and name:find("references") then
        local marks = vim.api.nvim_buf_get_extmarks(0, number, 0, -1, {})
        if #marks > 0 then return #marks end
      end
    end
  end)
  vim.lsp.buf.clear_references()
  return count
end

function features.rename()
  at("go kitchen")
  local before = text()
  vim.lsp.buf.rename("travel")
  settle(function() return text() ~= before end)
  local found = { raps = text(), tests = text("raps.test.rap") }
  for _, file in ipairs({ "raps.test.rap", "raps.rap" }) do
    vim.cmd("buffer " .. file)
    reset()
  end
  return found
end

function features.calls()
  at("go ?place")
  local found = { incoming = places(vim.lsp.buf.incoming_calls)[1][3] }
  at("tour")
  found.outgoing = places(vim.lsp.buf.outgoing_calls)[1][3]
  return found
end

function features.symbols()
  local function names(run)
    return vim.tbl_map(function(one) return one[3]:match("%] (.*)") end, places(run))
  end
  return {
    file = names(vim.lsp.buf.document_symbol),
    workspace = names(function() vim.lsp.buf.workspace_symbol("driv") end),
  }
end

function features.folding()
  if not vim.lsp.foldexpr then
    return vim.tbl_map(function(one)
      return { one.startLine + 1, one.endLine + 1 }
    end, ask("textDocument/foldingRange", document()))
  end
  vim.wo.foldmethod = "expr"
  vim.wo.foldexpr = "v:lua.vim.lsp.foldexpr()"
  settle(function() return vim.fn.foldlevel(5) > 0 end)
  vim.cmd("normal! zM")
  local found, row = {}, 1
  while row <= vim.fn.line("$") do
    local stop = vim.fn.foldclosedend(row)
    if stop > 0 then table.insert(found, { row, stop }) end
    row = math.max(row, stop) + 1
  end
  vim.wo.foldmethod = "manual"
  vim.cmd("normal! zE")
  return found
end

function features.colours()
  if not vim.lsp.semantic_tokens then
    return #ask("textDocument/semanticTokens/full", document()).data / 5
  end
  local found = {}
  for _, word in ipairs({ "define-rap", "go ?place", "?place", "; Go", '"world"' }) do
    at(word)
    found[word] = settle(function()
      local tokens = vim.lsp.semantic_tokens.get_at_pos()
      return tokens and tokens[1] and tokens[1].type
    end)
  end
  return found
end

function features.signature()
  at("robot")
  return popup(vim.lsp.buf.signature_help)
end

function features.completion()
  at("go hall")
  keys("cwt<C-x><C-o>")
  local found = settle(function()
    local items = vim.fn.complete_info({ "items" }).items
    return #items > 0 and vim.tbl_map(function(one) return one.word end, items)
  end)
  keys("<Esc>")
  settle(function() return vim.api.nvim_get_mode().mode == "n" end)
  reset()
  return found
end

function features.formatting()
  local function format(range)
    if vim.lsp.buf.format then
      vim.lsp.buf.format({ range = range })
    elseif range then
      vim.lsp.buf.range_formatting({}, range.start, range["end"])
    else
      vim.lsp.buf.formatting_sync()
    end
  end
  edit("  (succeed (at robot ?place))", " (succeed  (at robot\n?place))")
  edit("(t1 (go", "(t1  (go")
  local found = { file = changed(format) }
  found.range = changed(function()
    format({ start = { 5, 0 }, ["end"] = { 6, 0 } })
  end)
  reset()
  return found
end

function features.typing()
  local rows = vim.fn.line("$")
  local found
  at("(go hall")
  if vim.lsp.on_type_formatting then
    keys("i<CR><Esc>")
    settle(function() return vim.fn.line("$") > rows end)
    found = settle(function() return vim.fn.getline("."):match("^ +%(go") end)
  else
    edit(" (go hall", "\n(go hall")
    at("(go hall")
    local params = here()
    params.ch = "\n"
    params.options = { tabSize = 2, insertSpaces = true }
    local edits = ask("textDocument/onTypeFormatting", params)
    vim.lsp.util.apply_text_edits(edits, vim.fn.bufnr(), client().offset_encoding)
    found = vim.fn.getline(".")
  end
  reset()
  return #found:match("^ *")
end

function features.inlay_hints()
  edit('(require "world")', '(require "world")\n(declare-kind room)')
  finding()
  local found
  if vim.lsp.inlay_hint then
    found = settle(function()
      local hints = vim.lsp.inlay_hint.get({ bufnr = 0 })
      return hints[1] and hints[1].inlay_hint.label
    end)
  else
    local params = vim.lsp.util.make_given_range_params({ 1, 0 }, { 14, 0 })
    found = settle(function()
      local hints = ask("textDocument/inlayHint", params)
      return hints[1] and hints[1].label
    end)
  end
  reset()
  return found
end

-- Wait for the code lenses of the buffer, and return their titles.
local function lenses()
  return settle(function()
    vim.lsp.codelens.refresh()
    pause(50)
    local found = {}
    for _, one in ipairs(vim.lsp.codelens.get(vim.fn.bufnr())) do
      if one.command then table.insert(found, one.command.title) end
    end
    return #found > 0 and found
  end)
end

-- Run the code lens at the cursor, and return the message, which begins with a text.
local function run_lens(start)
  vim.lsp.codelens.run()
  return settle(function()
    local last = shown[#shown]
    return last and last:find("^" .. start) and last
  end)
end

function features.code_lenses()
  local found = { raps = lenses() }
  vim.cmd("edit raps.test.rap")
  found.tests = lenses()
  at("(define-test")
  found.result = run_lens("test")
  vim.cmd("buffer raps.rap")
  return found
end

function features.agenda()
  local agenda = { '(require "hallway")', "(define-agenda day", "  (task (go-to coffee-machine)))" }
  local test = { '(require "day")', "(define-test day-ends", "  (world hallway)", "  (agenda day))" }
  vim.fn.writefile(agenda, "day.rap")
  vim.fn.writefile(test, "day.test.rap")
  vim.cmd("edit day.rap")
  local found = { titles = lenses() }
  at("(define-agenda")
  found.result = run_lens("agenda")
  vim.cmd("buffer raps.rap")
  return found
end

function features.python()
  vim.cmd("edit world.rap")
  at("drive")
  local found = { handler = jumped(vim.lsp.buf.definition) }
  vim.cmd("edit robot.py")
  at("driven")
  found.declaration = jumped(function() vim.cmd("RapDeclaration") end)
  vim.cmd("buffer raps.rap")
  return found
end

function features.test_files()
  vim.cmd("edit raps.test.rap")
  edit("go kitchen", "goo kitchen")
  finding("unknown-rap")
  local found = vim.diagnostic.get(0)[1].message
  reset()
  vim.cmd("buffer raps.rap")
  return found
end

function features.configuration()
  vim.fn.writefile({ "[check]", "selekt = 1" }, "rapc.toml")
  vim.cmd("silent write!")
  local found = settle(function()
    local buffer = vim.fn.bufnr("rapc.toml")
    local one = buffer > 0 and vim.diagnostic.get(buffer)[1]
    return one and one.message
  end)
  vim.fn.writefile({}, "rapc.toml")
  vim.cmd("silent write!")
  return found
end

session = coroutine.create(function()
  local names = vim.split(vim.env.FEATURES, " ")
  local found = {}
  vim.cmd("edit raps.rap")
  settle(function() return client() and client().initialized end)
  known("tour")
  for _, name in ipairs(names) do
    local start = vim.loop.hrtime()
    found[name] = features[name]()
    io.stderr:write(("%s %d ms\n"):format(name, (vim.loop.hrtime() - start) / 1e6))
  end
  vim.fn.writefile({ vim.fn.json_encode(found) }, "result.json")
end)
vim.schedule(go_on)
