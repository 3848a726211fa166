"""Two effects that task flights leave undecided: how well `infotraj design --separate` tells them apart."""
