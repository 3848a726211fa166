"""The local web app: flights of one folder, checked and diagnosed in a browser on this machine."""
