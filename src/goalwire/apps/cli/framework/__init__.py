"""What every command needs: nouns and verbs, output, failures, the graph, values."""
