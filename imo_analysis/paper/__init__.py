"""What the paper prints, as data: equations (1)-(23), Tables I-III, statements; `contents` has all of it in order."""
