;;; rap.el --- RAP in Emacs 28 or later, with Eglot  -*- lexical-binding: t -*-

;; Load this file from the init file.  Emacs 28 needs the package `eglot'; Emacs 29
;; contains it.

;;; Code:

(require 'eglot)
(require 'lisp-mode)

(define-derived-mode rap-mode lisp-data-mode "RAP"
  "Mode for RAP files."
  (setq-local comment-start "; ")
  (setq-local lisp-indent-function (lambda (_point state)
                                     (goto-char (1+ (elt state 1)))
                                     (1+ (current-column)))))

(font-lock-add-keywords
 'rap-mode
 '(("(\\(\\(?:define\\|declare\\|require\\)[a-z-]*\\)" 1 font-lock-keyword-face)
   ("(define-[a-z-]+ (?\\([^][ ()]+\\)" 1 font-lock-function-name-face)
   ("\\?[^][ ()]+" 0 font-lock-variable-name-face)))

(add-to-list 'auto-mode-alist '("\\.rap\\'" . rap-mode))

(defun rap-server (&optional _interactive)
  "Return the command of the server: in `.venv' of the project, or on the path."
  (let* ((root (locate-dominating-file default-directory ".venv/bin/rapc"))
         (own (and root (expand-file-name ".venv/bin/rapc" root))))
    (unless (or own (executable-find "rapc"))
      (user-error "No rapc was found: pip install 'rapc[lsp]'"))
    (list (or own "rapc") "lsp")))

(add-to-list 'eglot-server-programs '(rap-mode . rap-server))
(add-hook 'rap-mode-hook #'eglot-ensure)

(defun rap-project (folder)
  "Return the project of FOLDER: the folder above with a file `rapc.toml'."
  (let ((root (locate-dominating-file folder "rapc.toml")))
    (and root (cons 'transient root))))

(add-hook 'project-find-functions #'rap-project)

(defun rap-run ()
  "Run the test or the agenda at point."
  (interactive)
  (let* ((server (eglot--current-server-or-lose))
         (params (list :textDocument (eglot--TextDocumentIdentifier)))
         (lenses (jsonrpc-request server :textDocument/codeLens params))
         (row (1- (line-number-at-pos nil t)))
         chosen)
    (seq-doseq (lens lenses)
      (let ((start (plist-get (plist-get (plist-get lens :range) :start) :line))
            (command (plist-get lens :command)))
        (when (and (<= start row) (string-prefix-p "run " (plist-get command :title)))
          (setq chosen command))))
    (unless chosen
      (user-error "No test and no agenda at point"))
    (eglot-execute-command server (intern (plist-get chosen :command))
                           (plist-get chosen :arguments))))

(defun rap-declaration ()
  "Go from Python to the declaration of the primitive or datum at point."
  (interactive)
  (let* ((project (project-current))
         (server (seq-find (lambda (one) (memq 'rap-mode (rap--modes one)))
                           (gethash project eglot--servers-by-project))))
    (unless server
      (user-error "No server: open a RAP file of the project first"))
    (let ((places (jsonrpc-request server :textDocument/definition
                                   (eglot--TextDocumentPositionParams))))
      (when (seq-empty-p places)
        (user-error "No declaration found"))
      (let ((place (elt places 0)))
        (xref-push-marker-stack)
        (find-file (eglot--uri-to-path (plist-get place :uri)))
        (goto-char (car (eglot--range-region (plist-get place :range))))))))

(defun rap--modes (server)
  "Return the modes of SERVER; versions of Eglot differ."
  (if (fboundp 'eglot--major-modes)
      (eglot--major-modes server)
    (list (eglot--major-mode server))))

(provide 'rap)
;;; rap.el ends here
