;;; emacs.el --- All features of the server in Emacs  -*- lexical-binding: t -*-

;; Read by `emacs --batch': uses every feature of the server, as a user does, and writes
;; what the editor shows to `result.json'.  Eglot 1.9 has no call hierarchy, folding,
;; semantic tokens, inlay hints and code lenses: the session sends the requests itself.
(require 'cl-lib)
(require 'imenu)

(setq eglot-sync-connect 60 eglot-autoshutdown t make-backup-files nil
      create-lockfiles nil eglot-confirm-server-initiated-edits nil
      eglot-send-changes-idle-time 0 last-nonmenu-event ?x)

(require 'jsonrpc)
(setq jsonrpc-default-request-timeout 60)

(cl-defmethod eglot-initialization-options (_server)
  '(:errorDelay 0 :delay 0))

(defvar shown nil "The messages of the server.")
(cl-defmethod eglot-handle-notification :before
  (_server (_method (eql window/showMessage)) &key message &allow-other-keys)
  (push message shown))

(defun settle (ready)
  "Wait until READY returns a value, and return the value."
  (let ((end (+ (float-time) 60)) found)
    (while (and (not (setq found (funcall ready))) (< (float-time) end))
      (accept-process-output nil 0.01))
    (or found (error "No answer: %S %S %S" shown (findings) (buffer-string)))))

(defun findings ()
  "Return the messages of the findings in the buffer."
  (flymake-start) ; without a display, no command starts it
  (mapcar #'flymake-diagnostic-text (flymake-diagnostics)))

(defun finding (text)
  "Wait for a finding whose message contains TEXT; without TEXT for the end of all."
  (eglot--signal-textDocument/didChange)
  (settle (lambda ()
            (if text (seq-find (lambda (one) (string-search text one)) (findings))
              (null (findings))))))

(defun ask (method &rest params)
  "Send a request about the buffer."
  (jsonrpc-request (eglot--current-server-or-lose) method
                   `(:textDocument ,(eglot--TextDocumentIdentifier) ,@params)))

(defun at (text)
  "Go to TEXT, from the start of the buffer."
  (goto-char (point-min))
  (let ((case-fold-search nil)) (search-forward text))
  (goto-char (match-beginning 0)))

(defun edit (old new)
  "Replace OLD in the buffer by NEW, once."
  (at old)
  (delete-region (match-beginning 0) (match-end 0))
  (insert new)
  (eglot--signal-textDocument/didChange))

(defun reset ()
  "Read the buffer again, and wait for the check of the server.
The server offers to extract the steps of `tour' only after that."
  (revert-buffer t t t)
  (finding nil)
  (when (equal (buffer-name) "raps.rap")
    (at "(t1")
    (settle (lambda ()
              (seq-find (lambda (one) (string-prefix-p "Extract" (plist-get one :title)))
                        (eglot-code-actions (point) (- (point-max) 5)))))))

(defun act (title start end)
  "Apply the action with TITLE between START and END, and return the text."
  (let ((before (buffer-string)))
    (settle
     (lambda ()
       (when (seq-find (lambda (one) (equal title (plist-get one :title)))
                       (eglot-code-actions start end))
         (cl-letf (((symbol-function 'completing-read) (lambda (&rest _) title)))
           (eglot-code-actions start end nil t))
         (settle (lambda ()
                   (and (not (equal before (buffer-string))) (buffer-string)))))))))

(defun after (function)
  "Return the text after FUNCTION, and restore the text."
  (let ((before (buffer-string)) found)
    (funcall function)
    (setq found (buffer-string))
    (erase-buffer)
    (insert before)
    (eglot--signal-textDocument/didChange)
    found))

(defun said (function)
  "Return the text that FUNCTION passes to eldoc."
  (let (found)
    (funcall function (lambda (text &rest _) (setq found text)))
    (substring-no-properties (settle (lambda () found)))))

(defun here ()
  "Return the file and the row of point."
  (vector (file-name-nondirectory (buffer-file-name)) (line-number-at-pos)))

(defun places (items)
  "Return the file and the row of each of ITEMS of xref."
  (vconcat (mapcar (lambda (one)
                     (let ((place (xref-item-location one)))
                       (vector (file-name-nondirectory (xref-location-group place))
                               (xref-location-line place))))
                   items)))

(defun name-of (item)
  "Return the symbol at the place of ITEM of xref."
  (let ((place (xref-location-marker (xref-item-location item))))
    (with-current-buffer (marker-buffer place)
      (goto-char place)
      (substring-no-properties (thing-at-point 'symbol)))))

(defun leaves (index)
  "Return the names of the entries in INDEX of imenu."
  (mapcan (lambda (one)
            (if (imenu--subalist-p one) (leaves (cdr one))
              (list (substring-no-properties (car one)))))
          index))

(defun lenses ()
  "Return the titles of the code lenses of the buffer."
  (vconcat (mapcar (lambda (one) (plist-get (plist-get one :command) :title))
                   (ask :textDocument/codeLens))))

(defun feature-findings ()
  (edit "(t1 (go kitchen))" "(t1 (goo kitchen))\n      (t1 (go hall))")
  (finding "unknown RAP")
  (finding "duplicate tag")
  (prog1 (vconcat (mapcar (lambda (one)
                            (vector (line-number-at-pos (flymake-diagnostic-beg one))
                                    (flymake-diagnostic-text one)))
                          (sort (flymake-diagnostics)
                                (lambda (one other)
                                  (< (flymake-diagnostic-beg one)
                                     (flymake-diagnostic-beg other))))))
    (reset)))

(defun feature-quick_fix ()
  (edit "go kitchen" "goo kitchen")
  (finding "unknown RAP")
  (at "goo")
  (prog1 (act "Write `go`" (point) (point))
    (reset)))

(defun feature-fix_all ()
  (edit "; Go to" "; rapc: ignore[unbound-variable]\n; Go to")
  (finding "suppress")
  (prog1 (act "Apply all safe fixes" (point-min) (point-min))
    (reset)))

(defun feature-suppress ()
  (edit "go hall" "go kitchen")
  (finding "copied-step")
  (at "(go kitchen)))))")
  (prog1 (act "Ignore copied-step here" (point) (point))
    (reset)))

(defun feature-declare ()
  (edit "(succeed (at robot ?place))" "(succeed (seen ?place north))")
  (finding "seen")
  (at "seen")
  (prog1 (act "Declare the proposition `seen`" (point) (point))
    (reset)))

(defun feature-define ()
  (edit "(go hall)" "(inspect hall => ?seen)")
  (finding "unknown RAP")
  (at "inspect")
  (prog1 (act "Define the RAP `inspect`" (point) (point))
    (reset)))

(defun feature-extract_and_inline ()
  (at "(t1")
  (let ((extracted (act "Extract the steps into a RAP" (point) (- (point-max) 5))))
    (at "(t1 (tour")
    (prog1 `(:extracted ,extracted
             :inlined ,(act "Inline `tour-t1`" (point) (point)))
      (reset))))

(defun feature-hover ()
  (at "drive")
  (said #'eglot-hover-eldoc-function))

(defun feature-definition ()
  (at "drive")
  (xref-find-definitions (xref-backend-identifier-at-point 'eglot))
  (prog1 (here)
    (switch-to-buffer "raps.rap")))

(defun feature-references ()
  (at "go kitchen")
  (places (xref-backend-references 'eglot (xref-backend-identifier-at-point 'eglot))))

(defun feature-highlight ()
  (at "?place")
  (said #'eglot-hover-eldoc-function)
  ;; The highlights of the place before may still arrive.
  (settle (lambda ()
            (and (seq-some (lambda (one) (<= (overlay-start one) (point) (overlay-end one)))
                           eglot--highlights)
                 (length eglot--highlights)))))

(defun feature-rename ()
  (at "go kitchen")
  (eglot-rename "travel")
  (let ((raps (buffer-string))
        (tests (with-current-buffer "raps.test.rap" (buffer-string))))
    (with-current-buffer "raps.test.rap" (reset))
    (reset)
    `(:raps ,raps :tests ,tests)))

(defun feature-calls ()
  (at "go ?place")
  (let* ((params (eglot--TextDocumentPositionParams))
         (position (list :position (plist-get params :position)))
         (go (elt (apply #'ask :textDocument/prepareCallHierarchy position) 0))
         (callers (ask :callHierarchy/incomingCalls :item go))
         (tour (plist-get (elt callers 0) :from))
         (called (ask :callHierarchy/outgoingCalls :item tour)))
    `(:incoming ,(plist-get tour :name)
      :outgoing ,(plist-get (plist-get (elt called 0) :to) :name))))

(defun feature-symbols ()
  `(:file ,(vconcat (leaves (eglot-imenu)))
    :workspace ,(vconcat (mapcar #'name-of (xref-backend-apropos 'eglot "driv")))))

(defun feature-folding ()
  (vconcat (mapcar (lambda (one)
                     (vector (1+ (plist-get one :startLine)) (1+ (plist-get one :endLine))))
                   (ask :textDocument/foldingRange))))

(defun feature-colours ()
  (let ((data (plist-get (ask :textDocument/semanticTokens/full) :data)))
    (font-lock-ensure)
    `(:tokens ,(/ (length data) 5)
      :faces ,(vconcat (mapcar (lambda (one)
                                 (at one)
                                 (symbol-name (get-text-property (point) 'face)))
                               '("define-rap" "go ?place" "?place" "Go to" "\"world"))))))

(defun feature-signature ()
  (at "robot")
  (said #'eglot-signature-eldoc-function))

(defun feature-completion ()
  (edit "go hall" "tou hall")
  (backward-char 5)
  (let ((completion-show-inline-help nil)) (completion-at-point))
  (prog1 (vector (substring-no-properties (thing-at-point 'symbol)))
    (reset)))

(defun feature-formatting ()
  (edit "  (succeed (at robot ?place))" " (succeed  (at robot\n?place))")
  (edit "(t1 (go" "(t1  (go")
  (prog1
      `(:file ,(after #'eglot-format-buffer)
        :range ,(after (lambda () (at "(succeed") (eglot-format (point) (1+ (point))))))
    (reset)))

(defun feature-typing ()
  (electric-indent-local-mode -1)
  (at "(go hall")
  (setq last-input-event ?\n last-command-event ?\n)
  (newline nil t)
  (prog1 (current-indentation)
    (reset)))

(defun feature-inlay_hints ()
  (edit "(require \"world\")" "(require \"world\")\n(declare-kind room)")
  (finding nil)
  (let ((range '(:start (:line 0 :character 0) :end (:line 14 :character 0))))
    (prog1 (settle (lambda ()
                     (let ((hints (ask :textDocument/inlayHint :range range)))
                       (and (not (seq-empty-p hints)) (plist-get (elt hints 0) :label)))))
      (reset))))

(defun feature-code_lenses ()
  (let ((raps (lenses)))
    (switch-to-buffer "raps.test.rap")
    (goto-char (point-max))
    (let ((tests (lenses)))
      (rap-run)
      (settle (lambda () shown))
      (switch-to-buffer "raps.rap")
      `(:raps ,raps :tests ,tests :result ,(car shown)))))

(defun feature-python ()
  (find-file "world.rap")
  (at "drive")
  (xref-find-definitions (xref-backend-identifier-at-point 'eglot))
  (let ((handler (here)))
    (find-file "robot.py")
    (at "driven")
    (rap-declaration)
    (prog1 `(:handler ,handler :declaration ,(here))
      (switch-to-buffer "raps.rap"))))

(defun feature-test_files ()
  (switch-to-buffer "raps.test.rap")
  (edit "go kitchen" "goo kitchen")
  (prog1 (finding "unknown RAP")
    (reset)
    (switch-to-buffer "raps.rap")))

(defun feature-configuration ()
  (write-region "[check]\nselekt = 1\n" nil "rapc.toml")
  (set-buffer-modified-p t)
  (save-buffer)
  (prog1 (settle (lambda ()
                   (let ((found (seq-find (lambda (one) (string-suffix-p "rapc.toml" (car one)))
                                          flymake-list-only-diagnostics)))
                     (and (cdr found) (flymake-diagnostic-text (cadr found))))))
    (write-region "" nil "rapc.toml")))

(defun session ()
  "Use all features, and write what they show."
  (dolist (file '("raps.test.rap" "raps.rap"))
    (find-file file)
    (unless (eglot-current-server)
      (apply #'eglot (eglot--guess-contact)))
    (eglot--maybe-activate-editing-mode))
  (reset)
  (let (found)
    (condition-case problem
        (dolist (name (split-string (getenv "FEATURES")))
          (let ((start (float-time)))
            (setq found (plist-put found (intern (concat ":" name))
                                   (funcall (intern (concat "feature-" name)))))
            (message "%s %d ms" name (* 1000 (- (float-time) start)))))
      (error (setq found (list :problem (format "%S" problem)))))
    (with-temp-file "result.json"
      (insert (json-serialize found)))))

(session)
