"""What a history is asked, a module for each subject: rows of answers are made here."""
