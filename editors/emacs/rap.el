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

(add-to-list 'auto-mode-alist '("\\.rap\\'" . rap-mode))

(defun rap-server (&optional _interactive)
  "Return the command of the server: in `.venv' of the project, or on the path."
  (let* ((root (locate-dominating-file default-directory ".venv/bin/rapc"))
         (own (and root (expand-file-name ".venv/bin/rapc" root))))
    (list (or own "rapc") "lsp")))

(add-to-list 'eglot-server-programs '(rap-mode . rap-server))
(add-hook 'rap-mode-hook #'eglot-ensure)

(defun rap-project (folder)
  "Return the project of FOLDER: the folder above with a file `rapc.toml'."
  (let ((root (locate-dominating-file folder "rapc.toml")))
    (and root (cons 'transient root))))

(add-hook 'project-find-functions #'rap-project)

(provide 'rap)
;;; rap.el ends here
