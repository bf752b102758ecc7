;; Read by `emacs --batch`: waits for results of the language server.
(setq eglot-sync-connect 30 eglot-autoshutdown t make-backup-files nil
      create-lockfiles nil eglot-confirm-server-initiated-edits nil)

(defun settle (ready)
  "Wait until READY returns a value, and return the value."
  (let ((end (+ (float-time) 30)) found)
    (while (and (not (setq found (funcall ready))) (< (float-time) end))
      (accept-process-output nil 0.05))
    (or found (error "No answer"))))

(defun findings ()
  "Return the messages of the findings in the buffer."
  (mapcar #'flymake-diagnostic-text (flymake-diagnostics)))

(defun ask (method &rest more)
  "Send a request about point."
  (jsonrpc-request (eglot--current-server-or-lose) method
                   (append (eglot--TextDocumentPositionParams) more)))

(defun from (text)
  "Go to TEXT."
  (goto-char (point-min))
  (search-forward text)
  (goto-char (match-beginning 0)))

(defun told (&rest values)
  "Print VALUES as JSON, for the test."
  (princ (concat "\ntold: " (json-serialize (vconcat values)) "\n")))
