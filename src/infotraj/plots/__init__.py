"""The experiment's figures and tables as PDF, PNG and text. The only room that imports matplotlib."""
