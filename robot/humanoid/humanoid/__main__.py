from humanoid.cli import main

raise SystemExit(main())
